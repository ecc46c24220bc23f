"""Records of the poses of a platform, and of what is proved of them."""
