"""Tell Django how the tables of this package are named."""

from django.apps import AppConfig


class ServeConfig(AppConfig):
    """The application; its tables begin with `serve_`."""

    name = "qdot.grader.serve"
    label = "serve"
