"""Studies of our own that pages of docs/ quote, one module each: `python -m studies.<module>`.

The figures of the paper itself are `aeroslosh paper` (master/paper)."""
