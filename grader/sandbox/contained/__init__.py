"""All that is in the process in which students' notebooks run: nothing else of qdot, and no reference.

`sandbox` starts this folder as a program (`__main__`), so that its modules are a package of their own, `contained`.

    kernel, calls           Linux's system calls for containment; which calls a notebook is refused
    guard, confine          the audit hook; the measures, each tried for itself
    folders                 folders removed, however deep
    attempts                what a probe tries in a notebook's place
    printing, values        formulas as text; values of Python, SymPy and NumPy as text
    callables               answers that are functions
    ipython, standins       a cell as Python; what stands for libraries that only show something
    session                 the variables of one notebook, and what Jupyter puts beside them
    runner, zygote          runs the cells of one notebook; forks for every notebook
"""
