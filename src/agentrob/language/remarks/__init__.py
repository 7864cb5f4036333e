"""Words by which remarks beside commands are recognised, one file a language; `parser.remarks` applies them."""
