"""Every form but notebooks in which an assignment is handed out: quizzes for learning platforms, paper, CI."""
