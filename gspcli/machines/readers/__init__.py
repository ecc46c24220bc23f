"""One reader a format: from the text of a file to a graph."""
