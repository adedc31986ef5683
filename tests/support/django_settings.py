"""Django settings for mypy, through which it finds the tables of grader/serve."""

SECRET_KEY = "of no service"
DEFAULT_AUTO_FIELD = "django.db.models.BigAutoField"
INSTALLED_APPS = [
    "django.contrib.contenttypes",
    "django.contrib.auth",
    "lti_tool",
    "qdot.grader.serve.apps.ServeConfig",
]
