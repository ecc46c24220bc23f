int hal_init(const char *name);
int hal_ready(int component);
int hal_exit(int component);
