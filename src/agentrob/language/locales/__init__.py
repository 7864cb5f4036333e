"""The languages: one file each, found by being here. `docs/languages.md` walks through adding one."""
