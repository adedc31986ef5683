"""The program `qdot`: the modules of its commands.

This package imports all other packages of qdot, but a command's module is imported only if the command is run.

    main                        the program
    problem_commands            the commands about arms and problems: init, families, questions, show, robots, solve
    class_commands              the commands for a class: generate, release, verify, compare, doctor
    grade_command               `qdot grade`
    export_commands             `qdot export`, `qdot report` and `qdot return`
    site_commands               `qdot site`
    student_command             the command for students, `qdot check`
    forget_command              `qdot forget`
    options, overview           options that commands share; overviews of the families and robots
    demo                        `qdot demo`: the simulated class
"""
