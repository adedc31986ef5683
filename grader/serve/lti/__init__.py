"""LTI 1.3 Advantage: launches from a learning platform, its class lists and its gradebook.

The library PyLTI1p3 makes and checks the messages, and django-lti stores platforms, courses and people as tables.

    platforms          the kinds of platforms: their addresses, and how a person registers a tool
    registering        register a platform, by hand or automatically, and connect its courses
    connection         requests to a platform, and the keys that sign them
    launch             sign in a person who opens qdot in a course
    people             the role of a person in a course, and the class list of the course
    columns            the columns of a course's gradebook
    pages, urls        the pages for launches and keys; their addresses
    outbox             send scores to the gradebook until they arrive
    choosing           deep linking: choose the assignment or the question that a course shows
"""
