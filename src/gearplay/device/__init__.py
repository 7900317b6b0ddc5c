"""The same kernels on a CUDA device: one run a thread, many runs side by side.

`words` lays runs out in the device's memory, `turns` is what a thread does there, `translate` has numba-cuda compile it together
with the kernels, `code` keeps what came of it, `driver` speaks to the device, and a `fleet` is the runs on it.
"""
