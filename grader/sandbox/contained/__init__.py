"""The code of the process in which students' notebooks run: nothing else of qdot, and no reference.

`sandbox` starts this folder as a program (`__main__`), so that its modules are the separate package `contained`.

    kernel, calls           Linux's system calls for isolation; the calls that a notebook may not use
    guard, confine          the audit hook; the measures, each tried separately
    folders                 removes folders of any depth
    attempts                what a probe tries instead of a notebook
    printing, values        formulas as text; values of Python, SymPy and NumPy as text
    callables               answers that are functions
    ipython, standins       a cell as Python; stand-ins for libraries that only display something
    session                 the variables of one notebook, and what Jupyter adds to them
    runner, zygote          runs the cells of one notebook; forks for every notebook
"""
