"""The code of the process in which students' notebooks run: nothing else of qdot, and no reference answers.

`sandbox` starts this folder as a program. The program loads only this folder, as the package `notebook_process`. So no
module of qdot or of a student can replace these modules. Each file, what it does, and what it defends against:

    kernel               Linux's system calls for isolation; decides nothing
    system_calls         the filter of system calls: against starting programs, sockets, other processes, mounts
    isolation            the measures, each tried separately: against reading and writing files of the machine, the
                         network, other processes, rights of root, and using up memory, time, disk and processes
    audit_hook           the same in Python: also against loading qdot for the answers
    folder_removal       removes folders: against folders too deep, or too restricted, to remove as usual
    escape_attempts      what a probe tries instead of a notebook: against a machine whose measures don't hold
    forking_process      forks for every notebook: against data or output that reaches another notebook, and processes
                         that continue after their notebook
    runner               runs the cells: against endless cells, and exceptions and answers that break the report
    session, ipython     Jupyter's variables and syntax by our own rules: against commands, and waiting for input
    stand_ins            replaces libraries that only display something: against failing without them
    answer_formatting    answers as text: against objects that pretend to be something else
    function_answers     answers that are functions: against code that waits to be called by the grader
"""
