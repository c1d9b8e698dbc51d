"""Names of the contact sites in the stator bores of magnetic bearings."""


def stator_site(bearing: str) -> str:
    """Return the name of the contact site in the stator bore of a bearing.

    Examples
    --------
    >>> stator_site("upper")
    'stator_upper'
    """
    return f"stator_{bearing}"
