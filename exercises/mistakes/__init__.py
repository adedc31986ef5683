"""The mistakes that people make in these derivations: one catalogue for diagnosis, quizzes and verification."""
