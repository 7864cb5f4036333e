"""One file per language; the registry finds every file here. `docs/inside/languages.md` shows how to add one."""
