"""Operations: which tool does what, from which line to which, and what says so."""
