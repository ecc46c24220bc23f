"""What types exist and what is known of each; standard library only."""
