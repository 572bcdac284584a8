"""Tool data: what CAM libraries, tool tables, lists and comments say about the tools of a program."""
