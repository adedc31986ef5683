"""The program `qdot`: its commands and what only they use.

It imports everything, each command when it is asked for.

    main                        the program
    problem_commands            the commands about what is asked: init, families, questions, show, robots, solve
    class_commands              the commands for a class: generate, verify, compare, doctor
    grade_command               `qdot grade`
    export_commands             `qdot export` and `qdot report`
    site_commands               `qdot site`
    student_command             the command for students, `qdot check`
    forget_command              `qdot forget`
    options, overview           options that commands share; the families at a glance
    demo                        the simulated class
    reference_pages             the pages of docs/ that list outlets, reports, schemas and what the packages offer
"""
