"""Build the web site: problems as JSON that a browser can show and grade, and the pages around them.

From the bottom up:

    keys, record                the numbers that a browser needs to grade; a problem as JSON
    bank_problem, bank          the list of problems; their files
    page, chapter, arms         the definition of a page; the book's examples; the gallery of arms
    robots                      example tables for the page "Your own arm"
    guide, command_reference    the order of the documentation; the command line as a page
    pages                       all pages
    build                       builds the whole site
"""
