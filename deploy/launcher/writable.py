"""Folders that cannot be written are told of before anything starts."""

import os


def require_writable(parser, folder, option):
    """Exits 2, naming `option` as the way out, unless files can be made in `folder`, which may have to be made
    itself."""
    nearest = folder
    while not os.path.exists(nearest):
        nearest = nearest.parent
    if not os.access(nearest, os.W_OK | os.X_OK):
        parser.error(
            f"cannot write to {folder} (it is another user's, or read-only): name a folder of your own "
            f"by {option} DIR"
        )
