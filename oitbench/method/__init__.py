"""What a method is: parameters, promises, and a plan of targets, buffers and passes."""
