"""The changes of the tables, in order.

Django writes them, and nothing else imports them.

    0001_initial                makes all tables
"""
