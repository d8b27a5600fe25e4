"""The arm in three dimensions: in a browser, in a picture, in a video."""
