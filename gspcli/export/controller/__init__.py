"""The next pose of a platform, proved, in C: a program for the controller of one machine."""
