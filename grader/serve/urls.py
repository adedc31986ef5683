"""The addresses of the service."""

from django.urls import include, path, register_converter
from django.urls.converters import StringConverter

from qdot.grader.serve import practice_pages, sign_in, staff_pages, student_pages


class KeyConverter(StringConverter):
    """The key of an assignment in an address."""

    regex = r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}"


register_converter(KeyConverter, "key")

urlpatterns = [
    path("", student_pages.show_home),
    path("in/<str:token>", sign_in.sign_in_by_link),
    path("out", sign_in.sign_out),
    path("lti/", include("qdot.grader.serve.lti.urls")),
    path("a/<key:key>/", student_pages.show_work_page),
    path("a/<key:key>/work", student_pages.get_work),
    path("a/<key:key>/answers", student_pages.post_answer),
    path("a/<key:key>/drafts", student_pages.put_draft),
    path("a/<key:key>/notebooks", student_pages.post_notebook),
    path("a/<key:key>/submissions/<int:number>", student_pages.get_submission),
    path("a/<key:key>/notebook.ipynb", student_pages.get_notebook),
    path("a/<key:key>/feedback", student_pages.get_feedback),
    path("a/<key:key>/practice/<int:number>/", practice_pages.show_practice_page),
    path("a/<key:key>/practice/<int:number>/work", practice_pages.get_practice),
    path("a/<key:key>/practice/<int:number>/answers", practice_pages.post_practice),
    path("a/<key:key>/practice/<int:number>/drafts", practice_pages.put_practice_draft),
    path("a/<key:key>/class/", staff_pages.show_class_page),
    path("a/<key:key>/class/results", staff_pages.get_results),
    path("a/<key:key>/class/students/<int:number>", staff_pages.get_student),
    path("a/<key:key>/class/overrides", staff_pages.post_override),
    path("a/<key:key>/class/extensions", staff_pages.post_extension),
    path("a/<key:key>/class/regrade", staff_pages.post_regrade),
    path("a/<key:key>/class/scores", staff_pages.resend_refused_scores),
    path("a/<key:key>/class/export.zip", staff_pages.get_export),
]
handler400 = "qdot.grader.serve.errors.report_refused_request"
handler403 = "qdot.grader.serve.errors.report_refused_request"
handler404 = "qdot.grader.serve.errors.report_refused_request"
handler500 = "qdot.grader.serve.errors.report_failure"
