"""The verdict as figures and as a page of HTML."""
