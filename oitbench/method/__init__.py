"""Declaration of methods: parameters, promises, and a plan of targets, buffers and passes."""
