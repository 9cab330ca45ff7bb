"""RAPID modules of ABB controllers (.mod, .sys, .prg)."""
