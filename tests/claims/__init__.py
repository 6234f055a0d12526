"""Tests of `oitbench/claims`."""
