"""Parts of mechanisms: one folder per kind with schema, packing, law and checks; `registry` lists them."""
