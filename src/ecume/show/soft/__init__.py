"""Pictures and figures of soft spheres. Start with `picture` (the entry in `FILMS`) and `figures`."""
