"""AgentRob: a post comes in, a robot moves, a reply goes out."""

__version__ = "0.1.0"
