"""Operations that robots declare: their words for the parser, clashes of these, and the sentences about them."""
