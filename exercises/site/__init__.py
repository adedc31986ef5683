"""The web site: problems as JSON that a browser can show and grade, and the pages around them.

From the bottom up:

    keys, record                the numbers by which a browser grades; a problem as JSON
    supply, bank                which problems there are; all of them written
    page, chapter, arms         what a page is; the book's examples; the gallery of arms
    robots                      tables that the page of one's own arm begins with
    guide, reference            how the documentation is arranged; the command line as a page
    pages                       all pages
    stale_files, build          what an earlier build wrote and is no more; all of it in a folder
"""
