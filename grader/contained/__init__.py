"""All that is in the process in which students' notebooks run: nothing else of qdot, and no reference.

`sandbox` starts this folder as a program (`__main__`), so that its modules are a package of their own, `contained`.
"""
