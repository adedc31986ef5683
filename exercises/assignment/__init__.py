"""Read and check an instructor's assignment folder, and write the notebooks of a class.

This package imports the packages that make problems and notebooks. The exports and the site import this package.

    assignment                  assignment.toml, roster.csv and the secret, as one object
    expected_forms              which values each key of assignment.toml expects, for error messages
    late_rule                   penalties for late work
    front_page                  what an exam on paper says above its first problem
    attempt_policy              which of a student's notebooks count
    class_list                  class lists that Canvas or Moodle has exported
    certified_problems          generates a class's problems, and replaces those that fail their certificate
    replacements                redrawn.csv, the list of replaced problems
    sets, release               ready-made sets of problems; makes an assignment folder and writes the notebooks
    handout                     packs the notebooks for handing them out
    store                       problems, figures and texts stored for grading
"""
