"""An output named `vacuum`: the cleaner."""
