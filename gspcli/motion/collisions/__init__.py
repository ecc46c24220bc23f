"""How far legs and bodies are from each other."""
