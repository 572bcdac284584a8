"""Operations: which tool does what, from which line to which, and who said so."""
