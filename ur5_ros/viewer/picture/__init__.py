"""Pictures without a browser: a camera, rays against bodies, and curves below."""
