"""What a person asks for: read, checked and written without compiling anything."""
