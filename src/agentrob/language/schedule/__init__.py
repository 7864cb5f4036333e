"""When a post is to be carried out: a time or a repetition beside the command."""
