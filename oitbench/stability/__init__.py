"""The stability suite: promised identities and hard cases, rendered with each method."""
