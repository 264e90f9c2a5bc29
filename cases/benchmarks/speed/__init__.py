"""Where users wait: seconds now, those of an earlier revision in the same run, and the limit.

Every probe is a script that uses only what both revisions have and prints its figures as JSON;
`suite` runs it under both in turns (`earlier` brings the older tree) and pairs them.
"""
