"""Other solvers on the benchmark's problems, one module each; none of them is needed by the package."""
