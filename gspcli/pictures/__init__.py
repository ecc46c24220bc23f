"""Pictures: platforms as scenes, the page that shows one, drawings and charts."""
