"""The adapters that come with the suite; each imports its engine when it is made."""
