"""How often the article's claimed patterns appear: over ranges of its unknown parameters, in ensembles and in single runs."""
