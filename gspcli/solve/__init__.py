"""An instance in, its assembly modes out."""
