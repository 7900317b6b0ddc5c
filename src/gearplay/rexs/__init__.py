"""Import of gearboxes that other programs wrote in the REXS format (rexs.info), versions 1.0 to 1.6."""
