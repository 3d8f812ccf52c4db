"""``python -m gaitway`` is the ``gaitway`` command."""

from gaitway.cli import main

raise SystemExit(main())
