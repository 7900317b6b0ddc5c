"""Study of Han, Liang, Zhang and Zhao, Entropy 2021, 23, 834: simulation, comparison with its test, report."""
