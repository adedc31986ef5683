"""The web site: problems as JSON that a browser can show and grade, and the pages around them."""
