"""`python -m navfix` is the command `navfix`."""

from navfix.cli import main

raise SystemExit(main())
