"""What methods promise and what they survive: identities and hard cases, rendered and judged."""
