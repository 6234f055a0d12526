"""What a method is: a declaration of targets, buffers and passes."""
