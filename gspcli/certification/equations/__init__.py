"""The constraints of an instance as equations in balls, in frames of their own."""
