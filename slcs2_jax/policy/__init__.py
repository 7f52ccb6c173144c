"""Controllers: what an agent does with what it sees. No physics."""
