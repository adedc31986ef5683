"""The addresses that a platform opens."""

from django.urls import path

from qdot.grader.serve.lti import choosing, launch, registering

urlpatterns = [
    path("login/<uuid:uuid>", launch.login),
    path("launch", launch.launch),
    path("keys", launch.show_keys),
    path("register/<uuid:uuid>", registering.register_dynamically),
    path("choose", choosing.choose),
]
