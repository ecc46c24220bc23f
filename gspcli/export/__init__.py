"""Other programs' files: MuJoCo models, and the equations of an instance as they read them."""
