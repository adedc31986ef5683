"""How problems and solutions are put: notation, wording, worked steps, Markdown to other markups."""
