"""Issuing and measuring draws."""
